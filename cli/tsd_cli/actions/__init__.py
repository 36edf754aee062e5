"""What the commands of 'tsd' do, once their options are read: all that is slow to load."""
